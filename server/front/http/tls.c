#include "tls.h"

#include <errno.h>
#include <gnutls/abstract.h>
#include <gnutls/gnutls.h>
#include <gnutls/x509.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "log.h"
#include "loop.h"

enum { CHAIN = 16, KEY_ID = 32 };

const char tls_priorities[] = "NORMAL:-VERS-ALL:+VERS-TLS1.3:+VERS-TLS1.2:%SERVER_PRECEDENCE";

typedef struct pair pair;
struct pair {
  pair *older;
  double replaced; /* (s) */
  gnutls_pcert_st chain[CHAIN];
  unsigned length;
  gnutls_privkey_t key;
};

/* GnuTLS tells the source nothing of ours, so this is where it looks. Handshakes may still be at an
 * older pair, for as long as a client may take for one. */
static pair *newest;
static const double handshake_seconds = 600;

/* ---- Reading ---- */

static void free_pair(pair *p) {
  for (unsigned k = 0; k < p->length; k++) gnutls_pcert_deinit(&p->chain[k]);
  if (p->key != NULL) gnutls_privkey_deinit(p->key);
  free(p);
}

static bool complain(fault *why, const char *name, const char *path, int code) {
  return fault_set(why, "%s: %.200s: %s", name, path,
                   code == GNUTLS_E_FILE_ERROR ? strerror(errno) : gnutls_strerror(code));
}

static bool read_chain(pair *p, const char *path, fault *why) {
  gnutls_datum_t text = {NULL, 0};
  unsigned length = CHAIN;
  int code = gnutls_load_file(path, &text);
  if (code == 0) {
    code = gnutls_pcert_list_import_x509_raw(p->chain, &length, &text, GNUTLS_X509_FMT_PEM, 0);
    gnutls_free(text.data);
  }
  if (code == 0) p->length = length;
  return code == 0 || complain(why, "tls-certificate", path, code);
}

static bool read_key(pair *p, const char *path, fault *why) {
  gnutls_datum_t text = {NULL, 0};
  int code = gnutls_load_file(path, &text);
  if (code == 0) code = gnutls_privkey_init(&p->key);
  if (code == 0) {
    code = gnutls_privkey_import_x509_raw(p->key, &text, GNUTLS_X509_FMT_PEM, NULL, 0);
  }
  if (text.data != NULL) gnutls_memset(text.data, 0, text.size);
  gnutls_free(text.data);
  return code == 0 || complain(why, "tls-key", path, code);
}

/* Is the key that of the first certificate? */
static bool check_match(const pair *p, const char *path, fault *why) {
  unsigned char id[2][KEY_ID];
  size_t size[2] = {KEY_ID, KEY_ID};
  gnutls_pubkey_t own = NULL;
  int code = gnutls_pubkey_init(&own);
  if (code == 0) code = gnutls_pubkey_import_privkey(own, p->key, 0, 0);
  if (code == 0) code = gnutls_pubkey_get_key_id(own, GNUTLS_KEYID_USE_SHA256, id[0], &size[0]);
  if (code == 0) {
    code = gnutls_pubkey_get_key_id(p->chain[0].pubkey, GNUTLS_KEYID_USE_SHA256, id[1], &size[1]);
  }
  if (own != NULL) gnutls_pubkey_deinit(own);
  if (code != 0) return complain(why, "tls-key", path, code);
  if (memcmp(id[0], id[1], KEY_ID) == 0) return true;
  return fault_set(why, "tls-key: %.200s is not the key of the certificate", path);
}

/* ---- Telling ---- */

static void tell_expiry(const pair *p) {
  char text[32] = "";
  gnutls_x509_crt_t first = NULL;
  struct tm t;
  if (gnutls_pcert_export_x509((gnutls_pcert_st *)&p->chain[0], &first) != 0) return;
  const time_t end = gnutls_x509_crt_get_expiration_time(first);
  gnutls_x509_crt_deinit(first);
  strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", gmtime_r(&end, &t));
  log_say(end < time(NULL) ? LOG_ERROR : LOG_INFO, "certificate", "it is good until %s", text);
}

static void tell_mode(const char *path) {
  struct stat facts;
  if (stat(path, &facts) != 0 || (facts.st_mode & (S_IROTH | S_IWOTH)) == 0) return;
  log_say(LOG_ERROR, "certificate", "%s may be read by everybody on this machine; chmod o= it",
          path);
}

/* ---- The newest ---- */

static void drop_old(void) {
  for (pair **at = &newest; *at != NULL;) {
    pair *p = *at;
    if (p == newest || p->replaced + handshake_seconds > loop_now()) {
      at = &p->older;
    } else {
      *at = p->older;
      free_pair(p);
    }
  }
}

bool tls_read(const char *certificate, const char *key, fault *why) {
  pair *p = calloc(1, sizeof *p);
  if (p == NULL) return fault_set(why, "out of memory");
  if (!read_chain(p, certificate, why) || !read_key(p, key, why) || !check_match(p, key, why)) {
    free_pair(p);
    return false;
  }
  tell_expiry(p);
  tell_mode(key);
  if (newest != NULL) newest->replaced = loop_now();
  p->older = newest;
  newest = p;
  drop_old();
  return true;
}

void tls_forget(void) {
  while (newest != NULL) {
    pair *p = newest;
    newest = p->older;
    free_pair(p);
  }
}

/* ---- Connections ---- */

static int give(gnutls_session_t session, const gnutls_datum_t *authorities, int count,
                const gnutls_pk_algorithm_t *algorithms, int length, gnutls_pcert_st **chain,
                unsigned *chain_length, gnutls_privkey_t *key) {
  (void)session, (void)authorities, (void)count, (void)algorithms, (void)length;
  *chain = newest->chain;
  *chain_length = newest->length;
  *key = newest->key;
  return 0;
}

void *tls_source(void) {
  return (void *)give;
}

void tls_send(void *session, const void *bytes, size_t size) {
  (void)gnutls_record_send(session, bytes, size);
}
