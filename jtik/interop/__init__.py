"""Conversion to and from other libraries: `jtik.interop.mink`, `jtik.interop.pink` and `jtik.interop.urdf`."""
