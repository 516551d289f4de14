"""What an estimate is made of: the car, the log, and the log on a grid."""
