"""What public functions take, and what is said where they are given something else."""
