"""Laws and passages under uniform noise, on panels that end where they are not smooth."""
