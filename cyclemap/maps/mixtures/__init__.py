"""Random maps: in each cycle one of several circle maps is drawn, then noise is added; their laws and schedules."""
