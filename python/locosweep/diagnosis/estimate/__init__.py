"""Parameter estimation: replays of the measured runs and least-squares fits."""
