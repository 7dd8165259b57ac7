"""The few loops that run as machine code: arrays in, arrays out, the same text interpreted."""
