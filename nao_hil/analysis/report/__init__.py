"""The report: one HTML file with every claim beside what was measured, nothing loaded from elsewhere."""
