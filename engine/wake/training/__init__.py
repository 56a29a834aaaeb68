"""Making a head for a phrase of one's own: synthetic voices say it and what is like it, the sound is spoilt in every
way that a room spoils it, a small network learns the difference, and is tried on voices that it has never heard.
"""
