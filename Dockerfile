# Nothing but our own scripts on plain Debian 12:  docker build -t assay . && docker run assay
FROM debian:12
WORKDIR /assay
COPY . .
RUN scripts/setup
CMD ["scripts/regress"]
