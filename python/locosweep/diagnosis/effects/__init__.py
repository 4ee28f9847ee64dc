"""The effects that a diagnosis may find, as the core's registry describes them."""
