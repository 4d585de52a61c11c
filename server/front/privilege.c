#include "privilege.h"

#include <errno.h>
#include <grp.h>
#include <pwd.h>
#include <string.h>
#include <unistd.h>

static bool become(const struct passwd *user, const char *directory) {
  return chown(directory, user->pw_uid, user->pw_gid) == 0 &&
         initgroups(user->pw_name, user->pw_gid) == 0 && setgid(user->pw_gid) == 0 &&
         setuid(user->pw_uid) == 0;
}

bool privilege_drop(const char *user, const char *directory, fault *why) {
  if (*user == '\0') return true;
  const struct passwd *found = getpwnam(user);
  if (found == NULL) return fault_set(why, "user: there is no user \"%.100s\"", user);
  if (geteuid() == found->pw_uid) return true;
  if (geteuid() != 0) return fault_set(why, "user: only root can become \"%.100s\"", user);
  if (become(found, directory)) return true;
  return fault_set(why, "user: cannot become \"%.100s\": %s", user, strerror(errno));
}
