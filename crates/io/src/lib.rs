//! File formats and nothing else: readers take bytes or text and return kernel types, writers the other way round.
