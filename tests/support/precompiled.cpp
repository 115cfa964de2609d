// The object that the test programs' precompiled header is built with.
