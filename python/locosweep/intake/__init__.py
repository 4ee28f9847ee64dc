"""The first step with a log of one's own: guess what it holds, write it as runs and a template."""
