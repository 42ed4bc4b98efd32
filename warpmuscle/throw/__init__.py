"""The throwing arm: muscles and synergies fitted to recorded motions, replayed, and used for new throws."""
