"""Logs of robots: files read, what is wrong with them told, and their samples on a uniform grid."""
