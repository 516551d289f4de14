"""What is built on the core: each application is a folder; the core does not import them."""
