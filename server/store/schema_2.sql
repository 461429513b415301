-- Version 2, from version 1. Every store goes through all versions, a new one too. Numbers are those of attempt.h.
CREATE TABLE attempt (
  job INTEGER NOT NULL REFERENCES job (number) ON DELETE CASCADE,
  number INTEGER NOT NULL,          -- of the lease
  engine TEXT NOT NULL,
  engine_id TEXT NOT NULL,
  state INTEGER NOT NULL,
  asked INTEGER NOT NULL,           -- durable before anything is started
  started INTEGER,
  ended INTEGER,
  place TEXT NOT NULL,
  exit_code INTEGER,
  signal INTEGER,
  cause INTEGER NOT NULL,
  words TEXT NOT NULL,
  PRIMARY KEY (job, number)
) STRICT, WITHOUT ROWID;

-- The attempts that were under way; of earlier ones only their number is known.
INSERT INTO attempt
  SELECT number, lease_attempt, 'local', '', 3, moment, moment, NULL, '', NULL, NULL, 0, ''
  FROM (SELECT job.number, lease_attempt, coalesce(max(moment), submitted) AS moment
        FROM job LEFT JOIN event ON event.job = job.number AND event.state = 2
        WHERE job.state = 2 GROUP BY job.number);

-- Lists by state and by label find their page without reading jobs that are not on it.
CREATE INDEX job_listed ON job (state, number, owner) WHERE deleted = 0;
CREATE INDEX label_by_value ON label (key, value, job);
CREATE INDEX request_by_moment ON request (moment);
