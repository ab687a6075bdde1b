"""The system below us: guest processes, files of others, programs, memory."""
