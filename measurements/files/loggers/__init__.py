"""Text files of data loggers."""
