"""Strategies with continuous parameters: exact gradients of bias and cost, search by them, and the front of both."""
