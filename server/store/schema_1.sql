-- Version 1. Moments are us since 1970; states and reasons are the numbers of job.h.
CREATE TABLE job (
  number INTEGER PRIMARY KEY AUTOINCREMENT,
  id TEXT NOT NULL UNIQUE,
  owner TEXT NOT NULL,
  name TEXT NOT NULL,
  state INTEGER NOT NULL,
  reason INTEGER NOT NULL,
  message TEXT NOT NULL,
  log_tail TEXT NOT NULL,
  priority INTEGER NOT NULL,
  spec TEXT NOT NULL,
  warnings TEXT NOT NULL,            -- one a line
  experiment_hash TEXT NOT NULL,
  state_digest TEXT NOT NULL,
  memory_estimate INTEGER NOT NULL,  -- bytes
  parent TEXT NOT NULL,
  parent_generation INTEGER NOT NULL,
  submitted INTEGER NOT NULL,
  started INTEGER,
  ended INTEGER,
  attempts INTEGER NOT NULL,
  lease_attempt INTEGER NOT NULL,
  faults INTEGER NOT NULL,
  losses INTEGER NOT NULL,
  checkpoint INTEGER NOT NULL,
  not_before INTEGER NOT NULL,
  stop_now INTEGER NOT NULL,
  samples INTEGER NOT NULL,
  events INTEGER NOT NULL,
  latest_sample BLOB NOT NULL,
  progress TEXT NOT NULL,
  deleted INTEGER NOT NULL DEFAULT 0  -- 1: its files are being removed, nobody sees it
) STRICT;
CREATE INDEX job_by_state ON job (state, priority DESC, number);
CREATE INDEX job_by_owner ON job (owner, number);

CREATE TABLE label (
  job INTEGER NOT NULL REFERENCES job (number) ON DELETE CASCADE,
  key TEXT NOT NULL,
  value TEXT NOT NULL,
  PRIMARY KEY (job, key)
) STRICT, WITHOUT ROWID;

-- Changes of state, in order.
CREATE TABLE event (
  job INTEGER NOT NULL REFERENCES job (number) ON DELETE CASCADE,
  place INTEGER NOT NULL,           -- from 0
  samples_before INTEGER NOT NULL,
  state INTEGER NOT NULL,
  reason INTEGER NOT NULL,
  message TEXT NOT NULL,
  attempt INTEGER NOT NULL,
  moment INTEGER NOT NULL,
  PRIMARY KEY (job, place)
) STRICT, WITHOUT ROWID;

-- Submissions that were answered; kept for 30 days.
CREATE TABLE request (
  owner TEXT NOT NULL,
  request_id TEXT NOT NULL,
  content TEXT NOT NULL,            -- SHA-256 of what was asked
  job TEXT NOT NULL,
  moment INTEGER NOT NULL,
  PRIMARY KEY (owner, request_id)
) STRICT, WITHOUT ROWID;
