"""The null backend: the same interface and checks as `gl`, no GPU. Records the call stream for tests.

device     NullDevice: creates, counts, records          resources  buffers with real bytes, textures with none
passes     the encoders                                  record     Call, CallStream
"""
