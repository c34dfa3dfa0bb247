"""What finished runs come to: figures, rows and scores, beside the published figures and the targets."""
