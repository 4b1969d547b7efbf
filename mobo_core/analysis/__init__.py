"""What a study means: tables, pictures and the report."""
