"""What several tests share: how robots are built, read back and broken."""
