"""The beam as it is printed: thick, elastic scales on a joint that gives, followed along one contact at a time."""
