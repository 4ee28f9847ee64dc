"""Blind check of the diagnosis: simulated cases whose cause is withheld.

The diagnosis gets files only. The truth of a case is written and hashed before the
first diagnosis starts and read after the last one ended.
"""
