"""The report: one HTML file with every claim and its measurement, nothing loaded from elsewhere."""
