"""A recorded run as one file that shows it without a server: a page for any browser, or a video."""
