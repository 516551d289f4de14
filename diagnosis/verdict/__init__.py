"""What a diagnosis concludes: the result and the parts that it consists of."""
