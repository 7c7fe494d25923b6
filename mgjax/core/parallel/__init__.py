"""Work spread over processes and machines, behind ``concurrent.futures.Executor``."""
