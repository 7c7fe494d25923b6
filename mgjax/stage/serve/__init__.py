"""The page's server: HTTP and WebSocket on this machine, and a worker that computes."""
