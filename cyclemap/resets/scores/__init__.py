"""What a reset is judged by: evenness, speed of forgetting, worth of its pushes, coverage."""
