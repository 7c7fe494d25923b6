"""Files to core types and back; units are converted here and nowhere else."""
