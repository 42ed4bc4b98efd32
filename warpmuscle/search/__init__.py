"""Search strategies: ask/tell, on plain numbers."""
