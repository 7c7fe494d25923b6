"""Building in stages: work cut into blocks that are kept, resumed and spread over workers."""
