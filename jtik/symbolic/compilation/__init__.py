"""From C to a shared library: the compiler, what it links, where libraries are kept, and several files at a time.

`jtik.symbolic.compile` is what others call.
"""
