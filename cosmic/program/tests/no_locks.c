// A library that makes the system refuse every lock on a file, as some network disks do. The environment variable ERRNO
// has the number of the error. Load it before the program: LD_PRELOAD=/path/to/no_locks.so
#include <errno.h>
#include <stdlib.h>

int flock(int file, int operation) {
  (void)file, (void)operation;
  const char *number = getenv("ERRNO");
  errno = number ? atoi(number) : ENOLCK;
  return -1;
}
