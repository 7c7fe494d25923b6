"""Match: players who pass a ball to one another, to whom, how and when the user says."""
