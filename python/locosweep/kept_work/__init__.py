"""Work over processes and shards, with records, so that what was done is not done again."""
