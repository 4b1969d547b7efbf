"""What a study means: tables, pictures, a page."""
