"""Plans of gaits: figures and studies."""
