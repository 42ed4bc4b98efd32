"""Search strategies: ask/tell, on plain numbers in the unit cube."""
