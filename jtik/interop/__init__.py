"""Bridges to other libraries, in both directions: `jtik.interop.mink` and `jtik.interop.pink`."""
