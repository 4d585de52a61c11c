/* privilege.h - who the daemon runs as once what needs root is done. Test: http.systemd. */
#ifndef SCATTERD_PRIVILEGE_H
#define SCATTERD_PRIVILEGE_H

#include "fault.h"

/* Becomes `user` with its groups, for good, if this is root and `user` is not "". `directory`, just
 * made by root or given to it, becomes the user's. False when there is no such user, or when this
 * is neither root nor that user already. */
bool privilege_drop(const char *user, const char *directory, fault *why);

#endif
