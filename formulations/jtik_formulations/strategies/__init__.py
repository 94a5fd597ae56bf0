"""Update laws, one module each."""
