"""Maps made from maps: branches and preimages, composition, iterates, inverses, conjugates."""
