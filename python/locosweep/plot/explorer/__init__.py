"""Pages that show a sweep, or runs, and answer to pointer and keys; they need no network."""
