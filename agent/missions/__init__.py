"""Missions: steps, files, the run that resumes them, the journal."""
