"""The report of a diagnosis: where the gap lies, how far it shrinks, page, figures, model."""
