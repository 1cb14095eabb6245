"""What was recorded: the reader and the writer of bags."""
