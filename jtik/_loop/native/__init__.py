"""Generated C: a step and a search in one call, searches in threads, and how C takes over from the virtual machine."""
