"""USD in: stages become arrays; the stage is never edited."""
