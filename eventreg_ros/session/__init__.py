"""One run: domain, processes, the client of the nodes, the result; prints nothing."""
