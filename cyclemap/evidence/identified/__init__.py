"""What an identification comes to: curves to be drawn and a material to be used."""
