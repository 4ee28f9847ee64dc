"""What the benches share: threads, tables, a description of the machine, peak memory."""
