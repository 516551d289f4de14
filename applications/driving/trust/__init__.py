"""What an answer has to pass: a car that does not contradict its file, tires that predict parts that were left out."""
