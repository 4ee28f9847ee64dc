"""Blind check of the diagnosis: cases whose cause is withheld, and how it fares on them.

The diagnosis gets files only. What is true of a case is written and hashed before
the first diagnosis starts and read after the last one ended.
"""
